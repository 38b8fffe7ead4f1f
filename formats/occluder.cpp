#include "formats/occluder.h"

namespace overcast {

const char* name(Representation representation) {
  switch (representation) {
    case Representation::volume:
      return "volume";
  }
  OVERCAST_REQUIRE(false, "representation is {}", static_cast<int>(representation));
}

}  // namespace overcast
