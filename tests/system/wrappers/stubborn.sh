#!/bin/sh
trap '' TERM
python3 "$SERVER" 7004
