"""What ``airlight bench`` and the benchmarks of the project measure with."""
