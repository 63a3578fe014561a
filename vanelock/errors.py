"""Errors that a user can mend."""


class InputError(ValueError):
    """Input that cannot be used.

    The message is one line that names the key or file, what was given and what is allowed. The
    command line prints it and exits with status 2; a library user catches it as a `ValueError`.
    """
