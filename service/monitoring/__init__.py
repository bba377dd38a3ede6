"""Monitoring: probes, and metrics for Prometheus of requests, jobs, workers and the store."""

from service.monitoring import health, prometheus
from service.monitoring.blobs_up import BlobsUp
from service.monitoring.request_times import MeasureRequests, RequestTimes
from service.monitoring.store_collector import StoreCollector

ROUTERS = (health.router, prometheus.router)

__all__ = ["ROUTERS", "BlobsUp", "MeasureRequests", "RequestTimes", "StoreCollector"]
