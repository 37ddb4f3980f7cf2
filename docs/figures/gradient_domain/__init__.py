"""The figures of the article on gradient-domain ReSTIR, made again with numbers."""
