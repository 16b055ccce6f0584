// Loads libcurl when it is first needed. Linking libcurl would load its thirty libraries at every start of the program,
// and the library for Python could not be used on systems without it.
#pragma once

#include <curl/curl.h>

#include "src/base/result.h"

namespace tessera::remote {

// The functions in use, without "curl_".
// clang-format off
#define TESSERA_CURL_FUNCTIONS(F) \
  F(easy_cleanup) F(easy_escape) F(easy_getinfo) F(easy_init) F(easy_setopt) F(easy_strerror) F(easy_unescape) F(free) \
  F(getdate) F(global_init) F(multi_add_handle) F(multi_cleanup) F(multi_info_read) F(multi_init) F(multi_perform) \
  F(multi_poll) F(multi_remove_handle) F(multi_setopt) F(multi_wakeup) F(slist_append) F(slist_free_all) F(url) \
  F(url_cleanup) F(url_get) F(url_set) F(version_info)
// clang-format on

struct CurlLibrary {
#define TESSERA_CURL_MEMBER(name) decltype(&::curl_##name) name = nullptr;  // NOLINT(bugprone-macro-parentheses)
  TESSERA_CURL_FUNCTIONS(TESSERA_CURL_MEMBER)
#undef TESSERA_CURL_MEMBER
};

// The library, loaded and ready, once. Error io when it is not installed or too old. Thread-safe.
Result<const CurlLibrary*> curl_library();

}  // namespace tessera::remote
