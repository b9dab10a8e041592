"""What other libraries read and write: whatever they raise becomes a FileError."""

from contextlib import contextmanager

from surflux._base.files import file_error
from surflux._core import Cancelled, FileError


@contextmanager
def outside(path, library, verb="read"):
    """The block is the library's; where it is not installed, the message says how it is."""
    try:
        yield
    except (FileError, Cancelled):
        raise
    except ImportError as error:
        missing = error.name or library
        raise file_error(path, f"needs {missing}, which is not installed: pip install 'surflux[scans]'") from error
    except Exception as error:
        said = " ".join(str(error).split()).partition(" **** ")[0][:300]  # behind which libe57 says it again
        raise file_error(path, f"{library} cannot {verb} it ({type(error).__name__}: {said})") from error
