"""What Prometheus is told: of the requests of this process, and of jobs, workers and the store."""

from service.metrics.collector import StoreCollector
from service.metrics.requests import MeasureRequests, RequestTimes

__all__ = ["MeasureRequests", "RequestTimes", "StoreCollector"]
