// What makes or reads a JSON document has memory: nlohmann's destructors take some, and end the process when there is
// none (docs/design.md, section 3). The linker puts these in the place of the functions that they call
// (CMakeLists.txt).
#include <filesystem>
#include <string>

#include "src/job/job_options.h"
#include "src/result/store/manifest.h"
#include "src/tiling/partition.h"
#include "src/tiling/routed_cloud.h"
#include "tests/memory/failing_memory.h"

namespace tessera::testing {
namespace {

class Exempt {
 public:
  Exempt() = default;
  ~Exempt() { set_exempt(before_); }
  Exempt(const Exempt&) = delete;
  Exempt& operator=(const Exempt&) = delete;

 private:
  bool before_ = set_exempt(true);
};

}  // namespace

// `symbol`: what the compiler calls it.
#define EXEMPT(Result, name, Argument, symbol)                            \
  Result real_##name(const Argument& argument) __asm__("__real_" symbol); \
  Result name(const Argument& argument) __asm__("__wrap_" symbol);        \
  Result name(const Argument& argument) {                                 \
    const Exempt exempt;                                                  \
    return real_##name(argument);                                         \
  }

EXEMPT(std::string, options_key, JobOptions, "_ZN7tessera11options_keyB5cxx11ERKNS_10JobOptionsE")
EXEMPT(Result<std::uint64_t>, write_plan, RoutedCloud, "_ZN7tessera10write_planERKNS_11RoutedCloudE")
EXEMPT(Result<RoutedCloud>, open_run, std::filesystem::path, "_ZN7tessera8open_runERKNSt10filesystem7__cxx114pathE")
EXEMPT(std::string, to_json, Partition, "_ZNK7tessera9Partition7to_jsonB5cxx11Ev")
EXEMPT(std::string, manifest_to_text, Manifest, "_ZN7tessera5store16manifest_to_textB5cxx11ERKNS_8ManifestE")

EXEMPT(Result<Manifest>, read_manifest, std::filesystem::path,
       "_ZN7tessera13read_manifestERKNSt10filesystem7__cxx114pathE")

#undef EXEMPT

}  // namespace tessera::testing
