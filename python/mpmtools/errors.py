"""What can go wrong, with the exit code of the command (the same codes as those of `mpm`)."""


class MpmError(Exception):
    """Base of the errors that a user can act on; the message says what, where and what to do."""

    exit_code = 5


class ConfigError(MpmError):
    """Wrong usage, or numbers outside the range of an equation."""

    exit_code = 2


class InputError(MpmError):
    """A file that is missing, damaged, or lacks something."""

    exit_code = 4


class UnstableError(MpmError):
    """A simulation became unstable."""

    exit_code = 3
