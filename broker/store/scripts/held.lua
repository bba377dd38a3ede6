-- Prelude of the scripts that change what a tenant keeps: the sum of the sizes, where there is one,
-- changes with them.
local function add_to_sum(held, size)
    if redis.call('EXISTS', held .. ':sum') == 1 then
        redis.call('INCRBY', held .. ':sum', string.format('%.0f', size))
    end
end

local function hold(held, key, size)
    local before = redis.call('ZSCORE', held, key) or 0
    redis.call('ZADD', held, size, key)
    add_to_sum(held, size - before)
end

local function release(held, key)
    local before = redis.call('ZSCORE', held, key)
    if before then
        redis.call('ZREM', held, key)
        add_to_sum(held, -before)
    end
end

