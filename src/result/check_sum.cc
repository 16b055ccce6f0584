#include "src/result/check_sum.h"

namespace tessera {

Status check_sum(const std::filesystem::path& path, std::uint64_t expected, ChecksumOf what) {
  BOOST_OUTCOME_TRY(sum, checksum_file(path, what));
  if (sum == expected) return success();
  return error(Errc::corrupt, path.string() + ": its checksum is " + checksum_text(sum) + ", but the manifest says " +
                                  checksum_text(expected) + ": the file was changed or damaged");
}

}  // namespace tessera
