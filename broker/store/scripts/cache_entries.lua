-- Prelude of the scripts that change the cache.
-- KEYS  1 names by last use, 2 sizes
-- ARGV  1 name, 2 prefix of blob keys
local function drop(name)
    redis.call('DEL', ARGV[2] .. name)
    redis.call('ZREM', KEYS[1], name)
    local size = redis.call('HGET', KEYS[2], name)
    if size then
        redis.call('HDEL', KEYS[2], name)
        redis.call('HINCRBY', KEYS[2], 'total', -size)
    end
end
