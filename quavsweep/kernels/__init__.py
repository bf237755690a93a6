"""From equations to a compiled step: Program, methods, printing, compiling."""
