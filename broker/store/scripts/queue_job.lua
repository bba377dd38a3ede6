-- Puts a job at its place in a queue that flows share fairly.
--
-- Start-time fair queueing (Goyal, Vin, Cheng, SIGCOMM 1996): a job's start tag is the queue's
-- virtual time, or the finish tag (start tag and cost) of its flow's job before it, if that is
-- later. Jobs wait in the order of their tags, equal ones in the order they came. The virtual time
-- is the start tag of the job that was served last.
--
-- KEYS: 1 list of waiting jobs, 2 sorted set of jobs by start tag (those served since the script
--       ran last are still in it), 3 virtual time, 4 RQ's record of the job
-- ARGV: 1 job id, 2 seconds after which the tags of an unused queue expire
local list, tags, clock, record = unpack(KEYS)
local job, seconds = unpack(ARGV)

local meta = cjson.decode(redis.call('HGET', record, 'meta') or '{}')
-- Versions before this one gave jobs no share.
local share = meta.share or {flow = '', cost = 1, lead = 0}
local flow = list .. ':flow:' .. share.flow

-- The virtual time never goes back: jobs with a lead have tags before it.
local now = tonumber(redis.call('GET', clock) or 0)
local first = redis.call('LINDEX', list, 0)
if not first then
    local last = redis.call('ZREVRANGE', tags, 0, 0, 'WITHSCORES')
    now = math.max(now, tonumber(last[2] or now))
    redis.call('DEL', tags)
else
    local tag = redis.call('ZSCORE', tags, first)
    if tag then
        local served = redis.call(
            'ZREVRANGEBYSCORE', tags, '(' .. tag, '-inf', 'WITHSCORES', 'LIMIT', 0, 1)
        now = math.max(now, tonumber(served[2] or now))
        redis.call('ZREMRANGEBYSCORE', tags, '-inf', '(' .. tag)
    end
end

-- Jobs that are queued again begin anew.
redis.call('ZREM', tags, job)
redis.call('ZREM', flow, job)
local earliest = now - share.lead
redis.call('ZREMRANGEBYSCORE', flow, '-inf', earliest - share.cost)
local before = redis.call('ZREVRANGE', flow, 0, 0, 'WITHSCORES')
local start = math.max(earliest, before[2] and before[2] + share.cost or earliest)

-- The first waiting job with a later tag; nil if there is none.
local function successor()
    while true do
        local later = redis.call('ZRANGEBYSCORE', tags, '(' .. start, '+inf', 'WITHSCORES', 'LIMIT', 0, 1)
        if not later[1] then return nil end
        local found, place
        for _, id in ipairs(redis.call('ZRANGEBYSCORE', tags, later[2], later[2])) do
            local at = redis.call('LPOS', list, id)
            if not at then
                redis.call('ZREM', tags, id)
            elseif not place or at < place then
                found, place = id, at
            end
        end
        if found then return found end
    end
end

local next_job = successor()
if next_job then
    redis.call('LINSERT', list, 'BEFORE', next_job, job)
else
    redis.call('RPUSH', list, job)
end
-- Lua prints numbers with 14 digits, too few for a tag.
local function exact(number) return string.format('%.17g', number) end
redis.call('ZADD', tags, exact(start), job)
redis.call('ZADD', flow, exact(start), job)
redis.call('SET', clock, exact(now), 'EX', seconds)
redis.call('EXPIRE', tags, seconds)
redis.call('EXPIRE', flow, seconds)
