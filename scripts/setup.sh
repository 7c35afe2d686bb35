#!/usr/bin/env bash
# Set-up for the Makefile: scripts/setup.sh venv | install WHAT [GROUP] | adapter | browser
set -euo pipefail
cd "$(dirname "$0")/.."

VENV=.venv
PYTHONS="python3 python3.14 python3.13 python3.12 python3.11"

fail() {
    echo "error: $*" >&2
    exit 1
}

# apt_install WHY PACKAGE...: as root, or with sudo; without rights it says what to install.
apt_install() {
    local why=$1
    shift
    local remedy="$why; install it and repeat: sudo apt-get install $*"
    command -v apt-get >/dev/null || fail "$why, and this system has no apt-get; install what corresponds to: $*"
    local as_root=()
    if [ "$(id -u)" -ne 0 ]; then
        command -v sudo >/dev/null || fail "$remedy"
        if sudo -n true 2>/dev/null; then
            as_root=(sudo -n)
        elif [ -t 0 ]; then
            as_root=(sudo)
        else
            fail "$remedy"
        fi
    fi
    echo "$why: installing $*" >&2
    local install=("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends "$@")
    # The lists of packages of a fresh machine are empty or old.
    "${install[@]}" >/dev/null 2>&1 || { "${as_root[@]}" apt-get update -q >/dev/null && "${install[@]}" >/dev/null; } || fail "$remedy"
}

# The first Python that the package supports; PYTHON names another.
find_python() {
    local candidate
    for candidate in ${PYTHON:-} $PYTHONS; do
        if command -v "$candidate" >/dev/null &&
            "$candidate" -c 'import sys; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 14))' 2>/dev/null; then
            echo "$candidate"
            return
        fi
    done
}

make_venv() {
    local python
    python=$(find_python)
    if [ -z "$python" ]; then
        apt_install "Python 3.11 to 3.14 is missing" python3 python3-venv
        python=$(find_python)
    fi
    if [ -z "$python" ]; then
        apt_install "Python 3.11 to 3.14 is missing" python3.11 python3.11-venv
        python=$(find_python)
    fi
    [ -n "$python" ] || fail "Python 3.11 to 3.14 is missing; install one and repeat"
    if ! "$python" -c 'import ensurepip, venv' 2>/dev/null; then
        local version
        version=$("$python" -c 'import sys; print(f"{sys.version_info[0]}.{sys.version_info[1]}")')
        apt_install "Python's venv is missing" "python$version-venv"
    fi
    "$python" -m venv "$VENV" || fail "the virtual environment $VENV could not be made with $python"
}

# install WHAT [GROUP]: the package, editable, with extras, and a dependency group.
install() {
    local python="$VENV/bin/python"
    # Groups need pip 25.1.
    "$python" -m pip install -qq --disable-pip-version-check "pip>=25.1"
    local group=()
    [ -z "${2:-}" ] || group=(--group "$2")
    echo "installing $1 ${group[*]}" >&2
    "$python" -m pip install -qq --disable-pip-version-check --editable "$1" "${group[@]}"
}

adapter() {
    local python="$VENV/bin/python"
    if "$python" -m airlight.app.setup_check; then
        return
    fi
    apt_install "no adapter answers (a driver for the GPU, or Mesa's software Vulkan)" mesa-vulkan-drivers libvulkan1
    "$python" -m airlight.app.setup_check || fail "no adapter answers, even with mesa-vulkan-drivers and libvulkan1"
}

# A browser for the tests of the viewer; without one they are skipped, and say so.
browser() {
    command -v chromium >/dev/null || command -v google-chrome >/dev/null && return
    (apt_install "no Chromium for the viewer's tests" chromium fonts-dejavu-core) || echo "the viewer's tests in a browser will be skipped" >&2
}

case "${1:-}" in
    venv) make_venv ;;
    install) install "${@:2}" ;;
    adapter) adapter ;;
    browser) browser ;;
    *) fail "usage: scripts/setup.sh venv | install WHAT [GROUP] | adapter | browser" ;;
esac
