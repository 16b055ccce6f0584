#include "tessera/failure.h"

#include "src/base/option.h"
#include "src/front/api/words.h"

namespace tessera {

Failure::Failure(Cause cause, const std::string& sentence)
    : std::runtime_error(render(sentence, member_name)),
      cause_(cause),
      marked_(std::make_shared<const std::string>(sentence)) {}
Failure::~Failure() = default;

std::string Failure::sentence(const OptionName& name) const { return render(*marked_, name); }

}  // namespace tessera
