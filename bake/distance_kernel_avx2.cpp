#include "bake/distance_kernel.inl"

namespace overcast {

const DistanceKernel kAvx2Kernel = {"avx2", avx2::witnessRow, avx2::fillBlock};

}  // namespace overcast
