#!/bin/sh
setsid sleep 1000 &
exec "$PROGRAM"
