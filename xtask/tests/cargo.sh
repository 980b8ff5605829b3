#!/bin/sh
# Stands in for cargo in a test: prints its arguments, one per line, and fails.
printf "%s\n" "$@"
echo "on stderr" >&2
exit 7
