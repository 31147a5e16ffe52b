#!/bin/sh
# Prints the path of a configuration with a network: the one that is named, if it has a section [network], else a
# copy with a console over telnet that asks for no password.
set -eu
config=$1
if grep -q '^[[:space:]]*\[network\]' "$config"; then
    echo "$config"
    exit
fi
mkdir -p out/console
{
    cat "$config"
    printf '\n[network]\nenable = true\nshell_enable = true\ngrbl_enable = true\nwebserver_enable = true\npassword_required = false\n'
} >out/console/config.ini
echo "$config has no [network]; out/console/config.ini has one, with consoles and a page that ask for no password" >&2
echo out/console/config.ini
