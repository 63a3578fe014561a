#!/bin/sh
# Find a Python that is new enough; it sets up the rest. PYTHON=... chooses another one.
set -eu
cd "$(dirname "$0")/.."

if [ -n "${PYTHON:-}" ]; then
    set -- "$PYTHON"
else
    set -- python3.11 python3 python3.12 python3.13 python3.14
fi
for python in "$@"; do
    if "$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; then
        exec "$python" tools/environment.py
    fi
done

echo "setup: no Python 3.11 or newer among: $*" >&2
echo "setup: install one (on Debian 12, as root: apt-get install --yes python3) or give PYTHON=/path/to/python" >&2
exit 1
