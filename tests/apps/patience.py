"""How long a test waits for what must come: only what hangs takes as long, on a machine with six others at work too."""
PATIENCE = 600  # [s]
