/* HXT on the points of a NumPy file of doubles (n x 3), in memory, no output: seconds of its hxtDelaunay() alone, cells and peak memory.
   Not part of the build: HXT is not ours. docs/benchmarks.md tells how to build it beside HXT's sources.
     hxt_points FILE.npy THREADS */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>

#include "hxt_mesh.h"
#include "hxt_tetDelaunay.h"

static double now(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static int fail(const char* what, const char* file) {
  fprintf(stderr, "%s: %s\n", file, what);
  return 1;
}

int main(int argc, char** argv) {
  if (argc != 3) return fail("usage: hxt_points FILE.npy THREADS", argv[0]);
  FILE* const in = fopen(argv[1], "rb");
  if (in == NULL) return fail("cannot be opened", argv[1]);
  unsigned char start[10];
  if (fread(start, 1, 10, in) != 10 || memcmp(start, "\x93NUMPY\x01", 7) != 0) return fail("no NumPy file of version 1", argv[1]);
  char header[65536] = {0};
  const size_t length = start[8] + 256U * start[9];
  unsigned long long n = 0;
  if (fread(header, 1, length, in) != length || strstr(header, "'<f8'") == NULL || strstr(header, "(") == NULL ||
      sscanf(strstr(header, "("), "(%llu, 3)", &n) != 1)
    return fail("not an array of n x 3 doubles", argv[1]);
  HXTMesh* mesh = NULL;
  if (hxtMeshCreate(&mesh) != HXT_STATUS_OK) return fail("no mesh", argv[1]);
  mesh->vertices.num = mesh->vertices.size = (uint32_t)n;
  if (hxtAlignedMalloc(&mesh->vertices.coord, 4 * n * sizeof(double)) != HXT_STATUS_OK) return fail("no memory", argv[1]);
  for (unsigned long long i = 0; i < n; ++i)
    if (fread(mesh->vertices.coord + 4 * i, sizeof(double), 3, in) != 3) return fail("ends too early", argv[1]);
  fclose(in);
  HXTDelaunayOptions options;
  memset(&options, 0, sizeof options);
  options.perfectDelaunay = 1;
  options.delaunayThreads = atoi(argv[2]);
  const double begin = now();
  if (hxtDelaunay(mesh, &options) != HXT_STATUS_OK) return fail("HXT has failed", argv[1]);
  const double seconds = now() - begin;
  unsigned long long cells = 0;
  for (uint64_t i = 0; i < mesh->tetrahedra.num; ++i) cells += mesh->tetrahedra.node[4 * i + 3] != UINT32_MAX;
  struct rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  printf("{\"seconds\": %.3f, \"points\": %u, \"cells\": %llu, \"peak_bytes\": %lld}\n", seconds, mesh->vertices.num, cells,
         (long long)usage.ru_maxrss * 1024);
  return hxtMeshDelete(&mesh) == HXT_STATUS_OK ? 0 : 1;
}
