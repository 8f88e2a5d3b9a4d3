#!/bin/sh
python3 "$SERVER" 7001
