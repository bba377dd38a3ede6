-- Count what is kept under a key, in place of what was.
-- KEYS  1 sizes by key
-- ARGV  1 key, 2 size in bytes
hold(KEYS[1], ARGV[1], tonumber(ARGV[2]))
