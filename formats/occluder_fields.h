// What archives (formats/archive.h) store of an Occluder.
#pragma once

#include "formats/occluder.h"

namespace overcast {

template <class Archive>
void fields(Archive& archive, Primitive& primitive) {
  archive(primitive.shape, primitive.centre, primitive.rotation, primitive.halfExtents);
}

template <class Archive>
void fields(Archive& archive, MeasuredError& error) {
  archive(error.max, error.rms, error.signErrors, error.samples, error.seed, error.p99, error.surfaceRms, error.skyRmse, error.method);
}

template <class Archive>
void fields(Archive& archive, Occluder& occluder) {
  archive(occluder.representation, occluder.uri, occluder.contentHash, occluder.bytes, occluder.primitive, occluder.bounds,
          occluder.influenceRadius, occluder.lipschitz, occluder.bits, occluder.inside, occluder.sheetThickness, occluder.signMethod,
          occluder.error, occluder.source, occluder.settingsHash);
}

}  // namespace overcast
