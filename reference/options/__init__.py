"""What production renderers add to ReSTIR GI: an option a file, beside the passes."""
