// What the tiles of a stage do: one object a tile. The exchange (src/exchange/tile_life.h) carries messages, puts tiles
// to sleep, moves them and begins them again after a loss; what a message says, only the program knows.
//
// One thread at a time calls a program, in the order that TileLife keeps. What stands on scratch beside the image
// the program reads and writes by itself.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "src/base/big_vector.h"
#include "src/base/figures.h"
#include "src/base/ids.h"
#include "src/base/result.h"
#include "src/exchange/tile_storage.h"

namespace tessera {

using Message = BigVector<std::byte>;
using Image = BigVector<std::byte>;

// Whose image a program is loaded from.
enum class ImageOf : std::uint8_t {
  sleeper,  // this object's own: it fell asleep
  earlier,  // another life's, in an earlier process or on another node: what it has told may be lost, and is told again
  settled   // another life's, which was quiet: finish() follows
};

// What is to be known of a tile that has come to the end of its stage: bytes that only the stage's owner understands.
using Receipt = BigVector<std::byte>;
inline constexpr std::size_t receipt_bytes_max = 1'000;
struct TileReceipt {
  TileId tile;
  Receipt receipt;
};

// What a tile leaves at the end of its stage.
class Finished {
 public:
  virtual ~Finished() = default;
  virtual std::uint64_t bytes() const = 0;  // in memory
  // Keeps it where whoever comes after the stage finds it, and then tells `done`, from any thread. May return before.
  // `done` does not throw, and is told whatever happens, unless this throws. Once.
  using Stored = std::function<void(Result<Receipt>)>;
  virtual void store(Stored done) = 0;
};

// Calls that change a program may throw Stopped, when the job is stopped, and Unsound, when what was read from scratch
// cannot be worked with. The program can then only be destroyed, or begin again.
class TileProgram {
 public:
  virtual ~TileProgram() = default;

  // From what the stage before has left alone.
  virtual Status begin() = 0;
  // Likewise, and from what settled() gave when all was quiet: finish() follows.
  virtual Status begin_settled(Message settled) = 0;
  // A message of another tile, or of an earlier life of this one. `current`: its sender went by the table by which this
  // tile goes. Error internal when no program of the stage can have sent it.
  virtual Status take(TileId from, bool current, Message message) = 0;
  // Works on all that was taken.
  virtual Status step() = 0;
  // Whether step() has something to do though nothing was taken.
  virtual bool due() const = 0;
  // What others must hear, none longer than message_bytes_max, by tile; forgets it.
  virtual std::vector<std::pair<TileId, Message>> messages() = 0;
  // These tiles (ascending) were reborn and know nothing. What they may not have heard, and others by way of them,
  // becomes messages again: no machine can do this for a program.
  virtual void replay_to(std::span<const TileId> reborn) = 0;

  // Puts on scratch what is in memory beside the image.
  virtual Status put_aside() = 0;
  // The whole state as bytes. REQUIRES: put_aside(), messages().
  virtual Image save() = 0;
  // False when these are not bytes that save() has made for this tile, or do not fit what stands beside them.
  virtual Result<bool> load(Image image, ImageOf whose) = 0;
  // An image with what was put aside, for another node; and the way back: as load() of an earlier one.
  virtual Result<Image> pack(Image image) = 0;
  virtual Result<bool> load_packed(Image packed) = 0;
  // Frees what an image tells again, and all after the end.
  virtual void free() = 0;

  // After quiescence: enough to begin the stage's end alone.
  virtual Message settled() const = 0;
  // After quiescence, once.
  virtual Result<std::unique_ptr<Finished>> finish() = 0;

  virtual std::size_t memory() const = 0;
  virtual const ExchangeCounts& counts() const = 0;  // also after free()
};

// Makes the programs of a stage. Outlives them.
class TilePrograms {
 public:
  virtual ~TilePrograms() = default;
  virtual std::unique_ptr<TileProgram> program_of(TileId tile) const = 0;
};

}  // namespace tessera
