"""Study file, stages and their cache, results file, command line."""
