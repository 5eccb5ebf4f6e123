"""From a Scene to finished frames: requests, worker processes, progress, and the record of what was done."""
