"""The steps of the store that must be one: Lua, which Redis runs without anything in between."""

from typing import Final

_MOVE: Final = """
local INDEX = {queued = 3, running = 4, succeeded = 5, failed = 6, cancelled = 7}
local quota = redis.call('HGET', KEYS[1], 'quota')
local function move(from, to)
    local score = redis.call('ZSCORE', KEYS[INDEX[from]], ARGV[1])
    if score then
        redis.call('ZREM', KEYS[INDEX[from]], ARGV[1])
        redis.call('ZADD', KEYS[INDEX[to]], score, ARGV[1])
    end
    if quota and from == 'queued' then
        redis.call('ZREM', quota, ARGV[1])
    end
    if quota and to == 'queued' then
        redis.call('ZADD', quota, score or 0, ARGV[1])
    end
    redis.call('HSET', KEYS[1], 'state', to)
end
local function count(what, kind, which)
    redis.call('HINCRBY', KEYS[8], what .. '|' .. kind .. '|' .. which, 1)
end
local kind = redis.call('HGET', KEYS[1], 'kind') or '?'
local function blame(problem)
    redis.call('HSET', KEYS[1], 'error', problem)
    count('failed', kind, cjson.decode(problem)['type'])
end
local function finish(from, to, now, ttl)
    move(from, to)
    count('ended', kind, to)
    redis.call('ZREM', KEYS[2], ARGV[1])
    redis.call('HSET', KEYS[1], 'ended', now)
    redis.call('EXPIRE', KEYS[1], ttl)
    local trace = redis.call('HGET', KEYS[1], 'trace')
    if trace then
        -- It outlives the record, however long the job waited and took.
        redis.call('SET', KEYS[1] .. ':trace', '', 'EX', ttl + trace)
    end
    if redis.call('HEXISTS', KEYS[1], 'webhook') == 1 then
        redis.call('ZADD', KEYS[9], redis.call('TIME')[1], ARGV[1])
    end
end
local function requeue(from)
    move(from, 'queued')
    redis.call('HDEL', KEYS[1], 'runner')
    redis.call('HSET', KEYS[1], 'stage', 'queued', 'fraction', '0')
end
local state = redis.call('HGET', KEYS[1], 'state')
local runner = redis.call('HGET', KEYS[1], 'runner')
"""
# KEYS of the scripts below: 1 the job, 2 the active jobs, 3 to 7 the index of each state, 8 the
# tallies, 9 the webhooks.
# ARGV[1] is the job's id. Each gives the state the job is in afterwards, or false if there is none.

CLAIM: Final = (
    _MOVE
    + """
-- ARGV: 2 runner, 3 now
if state ~= 'queued' then
    return {state, runner}
end
move('queued', 'running')
redis.call('HSET', KEYS[1], 'runner', ARGV[2])
redis.call('HSETNX', KEYS[1], 'started', ARGV[3])
return {'running', ARGV[2]}
"""
)
"""Begin a queued job; a job that is repeated after a crash keeps the time it first began."""

FINISH: Final = (
    _MOVE
    + """
-- ARGV: 2 runner, 3 now, 4 record's ttl, 5 end state, 6 error or '', 7 result or '', 8 its ttl
-- KEYS: 10 result
if state == ARGV[5] and runner == ARGV[2] then
    return state
end
if state ~= 'running' or runner ~= ARGV[2] then
    return state
end
if ARGV[7] ~= '' then
    redis.call('SET', KEYS[10], ARGV[7], 'EX', ARGV[8])
end
if ARGV[6] ~= '' then
    blame(ARGV[6])
end
if ARGV[5] == 'succeeded' then
    redis.call('HSET', KEYS[1], 'stage', 'done', 'fraction', '1')
end
finish('running', ARGV[5], ARGV[3], ARGV[4])
return ARGV[5]
"""
)
"""End a job that this runner holds; the result is there before anybody can see the state."""

CANCEL: Final = (
    _MOVE
    + """
-- ARGV: 2 now, 3 record's ttl
if state == 'queued' or (state == 'running' and runner == ARGV[1]) then
    finish(state, 'cancelled', ARGV[2], ARGV[3])
    return 'cancelled'
end
if state == 'running' then
    redis.call('HSETNX', KEYS[1], 'cancel', ARGV[2])
end
return state
"""
)
"""Cancel a queued job at once, and one that is done in turns, which no runner holds but itself; ask
the runner of any other running one to leave."""

LOSE: Final = (
    _MOVE
    + """
-- ARGV: 2 now, 3 record's ttl, 4 losses allowed, 5 error
if state ~= 'queued' and state ~= 'running' then
    return state
end
if redis.call('HEXISTS', KEYS[1], 'cancel') == 1 then
    finish(state, 'cancelled', ARGV[2], ARGV[3])
    return 'cancelled'
end
if redis.call('HINCRBY', KEYS[1], 'losses', 1) > tonumber(ARGV[4]) then
    blame(ARGV[5])
    finish(state, 'failed', ARGV[2], ARGV[3])
    return 'failed'
end
requeue(state)
return 'queued'
"""
)
"""Put a job whose process is gone back in the queue, or give it up after too many losses."""

ADMIT: Final = """
-- KEYS: 1 jobs queued by the caller.  ARGV: 1 job, 2 now, 3 limit or 0, 4 prefix of the jobs
local limit = tonumber(ARGV[3])
local state = redis.call('HGET', ARGV[4] .. ARGV[1], 'state')
if state or redis.call('ZSCORE', KEYS[1], ARGV[1]) then
    return 1
end
if limit > 0 and redis.call('ZCARD', KEYS[1]) >= limit then
    -- Whoever took a place and died before there was a job has left it behind.
    for _, job in ipairs(redis.call('ZRANGEBYSCORE', KEYS[1], '-inf', ARGV[2] - 60)) do
        if redis.call('HGET', ARGV[4] .. job, 'state') ~= 'queued' then
            redis.call('ZREM', KEYS[1], job)
        end
    end
    if redis.call('ZCARD', KEYS[1]) >= limit then
        return 0
    end
end
redis.call('ZADD', KEYS[1], ARGV[2], ARGV[1])
return 1
"""
"""Take a place in the queue; 0 when a caller has as many jobs queued as it may have."""

PROGRESS: Final = """
-- KEYS: 1 job.  ARGV: 1 runner, 2 stage, 3 fraction
local job = redis.call('HMGET', KEYS[1], 'state', 'runner', 'cancel')
if job[1] ~= 'running' or job[2] ~= ARGV[1] or job[3] then
    return 0
end
redis.call('HSET', KEYS[1], 'stage', ARGV[2], 'fraction', ARGV[3])
return 1
"""
"""Note progress; 0 when the job is cancelled or no longer this runner's."""

RESCHEDULE: Final = """
-- KEYS: 1 webhooks.  ARGV: 1 job, 2 when it was due, 3 when it is due again
local due = redis.call('ZSCORE', KEYS[1], ARGV[1])
if not due or tonumber(due) ~= tonumber(ARGV[2]) then
    return 0
end
redis.call('ZADD', KEYS[1], ARGV[3], ARGV[1])
return 1
"""
"""Take on a webhook that is due; 0 if somebody else has."""

BEGIN_DELIVERY: Final = """
-- KEYS: 1 job.  ARGV: 1 job that tries, 2 which try it is
if redis.call('EXISTS', KEYS[1]) == 0 then
    return 0
end
redis.call('HSET', KEYS[1], 'delivery_job', ARGV[1], 'attempts', ARGV[2])
return 1
"""
"""Note that a webhook is tried, unless its job has expired: the note would stay for good."""

NOTE_DELIVERY: Final = """
-- KEYS: 1 job, 2 webhooks.  ARGV: 1 job's id, 2 how it went, 3 when it is due again or ''
local there = redis.call('EXISTS', KEYS[1]) == 1
if there then
    redis.call('HSET', KEYS[1], 'delivery', ARGV[2])
end
if there and ARGV[3] ~= '' then
    redis.call('ZADD', KEYS[2], ARGV[3], ARGV[1])
else
    redis.call('ZREM', KEYS[2], ARGV[1])
end
"""
"""Note how a webhook went, unless its job has expired."""

UNLIST: Final = """
-- KEYS: 1 listing, 2 record.  ARGV: 1 entry
if redis.call('EXISTS', KEYS[2]) == 1 then
    return 0
end
return redis.call('ZREM', KEYS[1], ARGV[1])
"""
"""Take an entry out of a listing unless its record is there, be it there again."""

TAKE_UPLOAD: Final = """
-- KEYS: 1 candidate, 2 upload
if redis.call('EXISTS', KEYS[1]) == 1 then
    redis.call('RENAME', KEYS[1], KEYS[2])
end
"""
"""Make a candidate what a shape was uploaded as, once: where the answer of a transaction is lost,
all of it is sent again."""

RELEASE: Final = """
if redis.call('GET', KEYS[1]) == ARGV[1] then
    return redis.call('DEL', KEYS[1])
end
return 0
"""
"""Give a lock back if it is still one's own."""

RENEW: Final = """
if redis.call('GET', KEYS[1]) == ARGV[1] then
    return redis.call('PEXPIRE', KEYS[1], ARGV[2])
end
return 0
"""
"""Hold a lock for longer if it is still one's own."""

_DROP: Final = """
-- KEYS: 1 by last use, 2 sizes.  ARGV: 1 name, 2 prefix of the blobs
local function drop(name)
    redis.call('DEL', ARGV[2] .. name)
    redis.call('ZREM', KEYS[1], name)
    local size = redis.call('HGET', KEYS[2], name)
    if size then
        redis.call('HDEL', KEYS[2], name)
        redis.call('HINCRBY', KEYS[2], 'total', -size)
    end
end
drop(ARGV[1])
"""

CACHE_DROP: Final = _DROP
"""Take a spectrum out of the cache."""

CACHE_PUT: Final = (
    _DROP
    + """
-- KEYS: 3 blob.  ARGV: 3 now, 4 oldest use kept, 5 budget, 6 blob
for _, name in ipairs(redis.call('ZRANGEBYSCORE', KEYS[1], '-inf', ARGV[4])) do
    drop(name)
end
local size = #ARGV[6]
if size > tonumber(ARGV[5]) then
    return 0
end
while tonumber(redis.call('HGET', KEYS[2], 'total') or '0') + size > tonumber(ARGV[5]) do
    local oldest = redis.call('ZRANGE', KEYS[1], 0, 0)
    if #oldest == 0 then
        redis.call('HSET', KEYS[2], 'total', 0)
        break
    end
    drop(oldest[1])
end
redis.call('SET', KEYS[3], ARGV[6])
redis.call('ZADD', KEYS[1], ARGV[3], ARGV[1])
redis.call('HSET', KEYS[2], ARGV[1], size)
redis.call('HINCRBY', KEYS[2], 'total', size)
return 1
"""
)
"""Cache a spectrum, and drop what was not used for long or longest until all fit the budget."""
