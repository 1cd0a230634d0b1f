#!/usr/bin/env bash
# The checks of the continuous integration, before a push.
set -eu
exec "$(dirname "$0")/../.ci/run"
