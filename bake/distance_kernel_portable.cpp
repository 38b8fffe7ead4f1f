#include "bake/distance_kernel.inl"

namespace overcast {

const DistanceKernel kPortableKernel = {"portable", portable::witnessRow, portable::fillBlock};

}  // namespace overcast
