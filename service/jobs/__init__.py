"""Jobs: their state, their results, and cancelling them."""

from service.jobs.lookup import JobId, job_with_result, json_answer, packed_result

__all__ = ["JobId", "job_with_result", "json_answer", "packed_result"]
