#include "bake/distance_kernel.inl"

namespace overcast {

const DistanceKernel kAvx512Kernel = {"avx512", avx512::witnessRow, avx512::fillBlock};

}  // namespace overcast
