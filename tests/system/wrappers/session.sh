#!/bin/sh
setsid python3 "$SERVER" 7002 &
wait
