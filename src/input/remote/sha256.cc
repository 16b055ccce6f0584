#include "src/input/remote/sha256.h"

#include <dlfcn.h>

#include <array>

namespace tessera::remote {
namespace {

// Two functions of libcrypto 3, as its evp.h declares them; what they take and give as pointers is opaque here.
struct Sha256Library {
  const void* (*algorithm)() = nullptr;
  int (*digest)(const void* data, std::size_t count, unsigned char* out, unsigned* size, const void* algorithm,
                void* engine) = nullptr;
};

Sha256Library load_sha256() {
  Sha256Library found;
  void* const handle = ::dlopen("libcrypto.so.3", RTLD_NOW | RTLD_LOCAL);  // never unloaded: it registers its end
  if (handle == nullptr) return found;
  found.algorithm = reinterpret_cast<decltype(found.algorithm)>(::dlsym(handle, "EVP_sha256"));
  found.digest = reinterpret_cast<decltype(found.digest)>(::dlsym(handle, "EVP_Digest"));
  return found;
}

}  // namespace

std::optional<std::string> sha256(std::span<const std::byte> bytes) {
  if (bytes.empty()) return "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855";
  static const Sha256Library library = load_sha256();
  constexpr std::size_t digest_bytes = 32;
  std::array<unsigned char, 64> digest{};  // libcrypto may write up to EVP_MAX_MD_SIZE bytes
  unsigned size = 0;
  if (library.algorithm == nullptr || library.digest == nullptr ||
      library.digest(bytes.data(), bytes.size(), digest.data(), &size, library.algorithm(), nullptr) != 1 ||
      size != digest_bytes)
    return std::nullopt;
  constexpr const char* digits = "0123456789abcdef";
  std::string text;
  for (std::size_t i = 0; i < digest_bytes; ++i) {
    text += digits[digest[i] >> 4];
    text += digits[digest[i] & 15];
  }
  return text;
}

}  // namespace tessera::remote
