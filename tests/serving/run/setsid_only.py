# A program that leaves its session and draws for ever. Made for this project.
import os, time
os.setsid()
f = open('/dev/fb0', 'r+b', buffering=0)
f.write(b'\x00\x00\xff\x00' * 1000)
while True: time.sleep(1)
