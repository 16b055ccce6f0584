// Scratch files: files of frames, each with a checksum, so that damage is always noticed.
//
//   file   = frame*
//   frame  = magic    u32  "TsFb"
//            kind     u32  what the payload is
//            length   u64  bytes of the payload
//            run      u64  the run to which the frame belongs
//            item     u64  the item of the run: a tile, a node, ...
//            checksum u64  XXH3-64 of the payload, seeded with the XXH3-64 of the 32 bytes before
//            payload
//
// Numbers are little endian. Reading returns error corrupt, naming file and place, for a flipped bit, a truncation,
// rubbish at the end, a frame of another kind, and a frame that belongs to something else, as when files were
// exchanged. So it does for a frame of older software ("TsFr"), which did not say to what it belongs. Whole frames that
// are missing at the end of a file are not noticed; the writer must count its frames.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <vector>

#include "src/base/big_vector.h"
#include "src/base/files/names.h"
#include "src/base/result.h"

namespace tessera {

// The bytes of a frame besides its payload.
inline constexpr std::uint64_t frame_header_bytes = 40;

// What a frame belongs to.
struct FrameOwner {
  std::uint64_t run = 0;   // RoutedCloud::seal; 0 for files from before the run is routed
  std::uint64_t item = 0;  // within the run: the number of a tile, a node, an attempt
};

// Appends one frame. Makes the file, but not its folder. Opens and closes the file each time. After error io the end of
// the file may be damaged.
Status append_frame(const std::filesystem::path& path, ScratchKind kind, const FrameOwner& owner,
                    std::span<const std::byte> payload);
// Makes a file of one frame. Whenever the process ends, `path` is the old file or the new one. The file is not synced,
// so a power cut may damage it; reading notices that. Error io.
Status write_frame(const std::filesystem::path& path, ScratchKind kind, const FrameOwner& owner,
                   std::span<const std::byte> payload);

// Returns the payload of a file of one frame. Errors: io, also when there is no file; corrupt.
Result<BigVector<std::byte>> read_frame(const std::filesystem::path& path, ScratchKind kind, const FrameOwner& owner);
// Calls `visit` with the payloads of a file's frames in order, until `visit` returns an error. One payload is in memory
// at a time. Errors: io, also when there is no file; corrupt; those of `visit`.
using VisitFrame = std::function<Status(BigVector<std::byte> payload)>;
Status for_each_frame(const std::filesystem::path& path, ScratchKind kind, const FrameOwner& owner,
                      const VisitFrame& visit);

// Files of many frames that are read one by one.
//
// frame_offsets() lists where frames begin, without reading payloads. The list ends at damage. Owners in the list
// may be damaged, because checksums are not checked. Error io.
struct FrameOffset {
  FrameOwner owner;
  std::uint64_t at = 0;
};
Result<std::vector<FrameOffset>> frame_offsets(const std::filesystem::path& path, ScratchKind kind);
// Returns the payload of the frame that begins at byte `at`. Errors: io, corrupt.
Result<BigVector<std::byte>> read_frame_at(const std::filesystem::path& path, ScratchKind kind, const FrameOwner& owner,
                                           std::uint64_t at);

}  // namespace tessera
