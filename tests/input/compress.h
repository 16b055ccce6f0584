// Compressed bytes, for tests.
#pragma once

#include <zlib.h>
#include <zstd.h>

#include "tests/input/io_testing.h"

namespace tessera::testing_io {

inline Bytes gzip(const Bytes& plain) {
  z_stream stream{};
  constexpr int window_bits_max = 15, with_gzip_header = 16;
  EXPECT_EQ(deflateInit2(&stream, 6, Z_DEFLATED, window_bits_max + with_gzip_header, 8, Z_DEFAULT_STRATEGY), Z_OK);
  Bytes packed(deflateBound(&stream, plain.size()));
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(plain.data()));
  stream.avail_in = static_cast<uInt>(plain.size());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = static_cast<uInt>(packed.size());
  EXPECT_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
  packed.resize(stream.total_out);
  deflateEnd(&stream);
  return packed;
}

inline Bytes zstd(const Bytes& plain, int window_log = 0) {
  ZSTD_CCtx* context = ZSTD_createCCtx();
  ZSTD_CCtx_setParameter(context, ZSTD_c_checksumFlag, 1);
  if (window_log > 0) {
    ZSTD_CCtx_setParameter(context, ZSTD_c_windowLog, window_log);
    ZSTD_CCtx_setParameter(context, ZSTD_c_contentSizeFlag, 0);
  }
  Bytes packed(ZSTD_compressBound(plain.size()));
  ZSTD_inBuffer from{plain.data(), plain.size(), 0};
  ZSTD_outBuffer to{packed.data(), packed.size(), 0};
  // In two steps, as from a pipe: only then the window asked for is the one that is written.
  EXPECT_EQ(ZSTD_isError(ZSTD_compressStream2(context, &to, &from, ZSTD_e_continue)), 0u);
  EXPECT_EQ(ZSTD_compressStream2(context, &to, &from, ZSTD_e_end), 0u);
  packed.resize(to.pos);
  ZSTD_freeCCtx(context);
  return packed;
}

inline Bytes operator+(Bytes a, const Bytes& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

}  // namespace tessera::testing_io
