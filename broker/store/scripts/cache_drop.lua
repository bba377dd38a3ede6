-- Remove a blob from the cache.
drop(ARGV[1])
