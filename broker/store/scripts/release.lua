-- Count what was kept under a key no more.
-- KEYS  1 sizes by key
-- ARGV  1 key
release(KEYS[1], ARGV[1])
