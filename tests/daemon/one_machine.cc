// flock() as network file systems have it for folders: each machine has its own. For processes that play machines.
#include <sys/file.h>

extern "C" int flock(int, int) { return 0; }
