#!/bin/sh
(setsid python3 "$SERVER" 7003 &)
exec sleep 1000
