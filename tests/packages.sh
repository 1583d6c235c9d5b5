# shellcheck shell=bash
# To be sourced: Debian packages that a test needs. Uses the caller's folder $work and its function `skip`.

# Installs packages that are missing, one script at a time, or skips the test.
need() {
    if dpkg -s "$@" >"${work:?}/log" 2>&1; then return; fi
    command -v apt-get >/dev/null || skip "no apt-get to install $* with"
    [ "$(id -u)" = 0 ] || skip "some of $* are missing, and only root can install them"
    export DEBIAN_FRONTEND=noninteractive
    (flock 9 && timeout 120 apt-get update && timeout 240 apt-get install -y --no-install-recommends "$@") \
        9>"${TMPDIR:-/tmp}/parsph-packages.lock" >"$work/log" 2>&1 || skip "apt-get could not install $*"
}
