"""The figures of the ReSTIR GI paper, made again by this project, with their numbers.

Each figure is a function of its `Work` that returns a `PaperFigure`;
:mod:`reference.reports.figures.registry` lists them.
"""
