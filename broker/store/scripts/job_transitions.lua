-- Prelude of the scripts that move a job from one state to another.
--
-- KEYS  1 job, 2 active jobs, 3 to 7 index of each state, 8 counters, 9 webhooks, 10 result,
--       11 sizes of the tenant's blobs, 12 jobs that count towards the tenant's quota,
--       13 result as arrays, 14 result in brief, 15 validations that count towards it
-- ARGV  1 job's id
-- Each script returns the state the job is in afterwards, false if there is no such job; some also
-- return its runner.
local INDEX = {queued = 3, running = 4, succeeded = 5, failed = 6, cancelled = 7}
local state = redis.call('HGET', KEYS[1], 'state')
local runner = redis.call('HGET', KEYS[1], 'runner')
local kind = redis.call('HGET', KEYS[1], 'kind') or '?'
-- Key of the caller's queued jobs or validations; only listed jobs and validations have one.
local quota = redis.call('HGET', KEYS[1], 'quota')

local function count(name, label)
    redis.call('HINCRBY', KEYS[8], name .. '|' .. kind .. '|' .. label, 1)
end

local function move(from, to)
    local created = redis.call('ZSCORE', KEYS[INDEX[from]], ARGV[1])
    if created then
        redis.call('ZREM', KEYS[INDEX[from]], ARGV[1])
        redis.call('ZADD', KEYS[INDEX[to]], created, ARGV[1])
    end
    if quota and from == 'queued' then
        redis.call('ZREM', quota, ARGV[1])
    end
    if quota and to == 'queued' then
        redis.call('ZADD', quota, created or 0, ARGV[1])
    end
    redis.call('HSET', KEYS[1], 'state', to)
end

local function requeue(from)
    move(from, 'queued')
    redis.call('HDEL', KEYS[1], 'runner')
    redis.call('HSET', KEYS[1], 'stage', 'queued', 'fraction', '0')
end

local function set_error(problem)
    redis.call('HSET', KEYS[1], 'error', problem)
    count('failed', cjson.decode(problem)['type'])
end

local function finish(from, to, now, ttl)
    move(from, to)
    count('ended', to)
    redis.call('ZREM', KEYS[12], ARGV[1])
    redis.call('ZREM', KEYS[15], ARGV[1])
    redis.call('ZREM', KEYS[2], ARGV[1])
    redis.call('HSET', KEYS[1], 'ended', now)
    -- The field 'kept' holds the ttl of a job that serves another.
    redis.call('EXPIRE', KEYS[1], redis.call('HGET', KEYS[1], 'kept') or ttl)
    -- The field 'trace' holds the further seconds for which the tombstone outlives the record.
    local tombstone_ttl = redis.call('HGET', KEYS[1], 'trace')
    if tombstone_ttl then
        local tombstone = KEYS[1] .. ':trace'
        redis.call('SET', tombstone, redis.call('GET', tombstone) or '', 'EX', ttl + tombstone_ttl)
    end
    if redis.call('HEXISTS', KEYS[1], 'webhook') == 1 then
        redis.call('ZADD', KEYS[9], redis.call('TIME')[1], ARGV[1])
    end
end
