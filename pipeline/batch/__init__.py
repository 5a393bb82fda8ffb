"""Many runs: jobs, their journal, processes."""
