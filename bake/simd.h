// Simd: the few vector operations that the distance kernel needs, for the instruction set that the including file is compiled for.
// Everything lies in a namespace of that instruction set, so that the linker never mixes code of two of them.
#pragma once

#include <cstdint>

#if defined(__AVX512F__)
#include <immintrin.h>
#define OVERCAST_SIMD avx512
#elif defined(__AVX2__) && defined(__FMA__)
#include <immintrin.h>
#define OVERCAST_SIMD avx2
#else
#define OVERCAST_SIMD portable
#endif

namespace overcast::OVERCAST_SIMD {

/// Floats has kLanes lanes; Mask has one bit per lane, lane 0 the lowest.
using Mask = std::uint32_t;

/// a * b + c as the vectors do it: fused where they are.
static inline float multiplyAdd(float a, float b, float c) {
#if defined(__FMA__)
  return __builtin_fmaf(a, b, c);
#else
  return a * b + c;
#endif
}

#if defined(__AVX512F__)

constexpr int kLanes = 16;
struct Floats {
  __m512 v;
};
struct Ints {
  __m512i v;
};
struct Condition {
  __mmask16 v;
};
static inline Floats load(const float* p) {
  return {_mm512_loadu_ps(p)};
}
static inline void store(float* p, Floats a) {
  _mm512_storeu_ps(p, a.v);
}
static inline void store(std::int32_t* p, Ints a) {
  _mm512_storeu_si512(p, a.v);
}
static inline Floats all(float a) {
  return {_mm512_set1_ps(a)};
}
static inline Ints all(std::int32_t a) {
  return {_mm512_set1_epi32(a)};
}
static inline Floats operator+(Floats a, Floats b) {
  return {_mm512_add_ps(a.v, b.v)};
}
static inline Floats operator-(Floats a, Floats b) {
  return {_mm512_sub_ps(a.v, b.v)};
}
static inline Floats operator*(Floats a, Floats b) {
  return {_mm512_mul_ps(a.v, b.v)};
}
static inline Floats multiplyAdd(Floats a, Floats b, Floats c) {
  return {_mm512_fmadd_ps(a.v, b.v, c.v)};
}
static inline Floats multiplySubtractFrom(Floats a, Floats b, Floats c) {
  return {_mm512_fnmadd_ps(a.v, b.v, c.v)};
}
static inline Floats min(Floats a, Floats b) {
  return {_mm512_min_ps(a.v, b.v)};
}
static inline Floats max(Floats a, Floats b) {
  return {_mm512_max_ps(a.v, b.v)};
}
static inline Floats absolute(Floats a) {
  return {_mm512_abs_ps(a.v)};
}
static inline Condition less(Floats a, Floats b) {
  return {_mm512_cmp_ps_mask(a.v, b.v, _CMP_LT_OQ)};
}
static inline Condition operator&(Condition a, Condition b) {
  return {static_cast<__mmask16>(a.v & b.v)};
}
static inline Condition operator|(Condition a, Condition b) {
  return {static_cast<__mmask16>(a.v | b.v)};
}
static inline Mask bits(Condition a) {
  return a.v;
}
static inline bool any(Condition a) {
  return a.v != 0;
}
static inline Floats select(Condition c, Floats yes, Floats no) {
  return {_mm512_mask_mov_ps(no.v, c.v, yes.v)};
}
static inline Ints select(Condition c, Ints yes, Ints no) {
  return {_mm512_mask_mov_epi32(no.v, c.v, yes.v)};
}
static inline void storeWhere(Condition c, std::int32_t* p, Ints a) {
  _mm512_mask_storeu_epi32(p, c.v, a.v);
}
/// Lanes of `p` that share a bit with `mask`.
static inline Mask sharingBits(const std::uint32_t* p, std::uint32_t mask) {
  return _mm512_test_epi32_mask(_mm512_loadu_si512(p), _mm512_set1_epi32(static_cast<int>(mask)));
}

#elif defined(__AVX2__) && defined(__FMA__)

constexpr int kLanes = 8;
struct Floats {
  __m256 v;
};
struct Ints {
  __m256i v;
};
struct Condition {
  __m256 v;
};
static inline Floats load(const float* p) {
  return {_mm256_loadu_ps(p)};
}
static inline void store(float* p, Floats a) {
  _mm256_storeu_ps(p, a.v);
}
static inline void store(std::int32_t* p, Ints a) {
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(p), a.v);
}
static inline Floats all(float a) {
  return {_mm256_set1_ps(a)};
}
static inline Ints all(std::int32_t a) {
  return {_mm256_set1_epi32(a)};
}
static inline Floats operator+(Floats a, Floats b) {
  return {_mm256_add_ps(a.v, b.v)};
}
static inline Floats operator-(Floats a, Floats b) {
  return {_mm256_sub_ps(a.v, b.v)};
}
static inline Floats operator*(Floats a, Floats b) {
  return {_mm256_mul_ps(a.v, b.v)};
}
static inline Floats multiplyAdd(Floats a, Floats b, Floats c) {
  return {_mm256_fmadd_ps(a.v, b.v, c.v)};
}
static inline Floats multiplySubtractFrom(Floats a, Floats b, Floats c) {
  return {_mm256_fnmadd_ps(a.v, b.v, c.v)};
}
static inline Floats min(Floats a, Floats b) {
  return {_mm256_min_ps(a.v, b.v)};
}
static inline Floats max(Floats a, Floats b) {
  return {_mm256_max_ps(a.v, b.v)};
}
static inline Floats absolute(Floats a) {
  return {_mm256_andnot_ps(_mm256_set1_ps(-0.0f), a.v)};
}
static inline Condition less(Floats a, Floats b) {
  return {_mm256_cmp_ps(a.v, b.v, _CMP_LT_OQ)};
}
static inline Condition operator&(Condition a, Condition b) {
  return {_mm256_and_ps(a.v, b.v)};
}
static inline Condition operator|(Condition a, Condition b) {
  return {_mm256_or_ps(a.v, b.v)};
}
static inline Mask bits(Condition a) {
  return static_cast<Mask>(_mm256_movemask_ps(a.v));
}
static inline bool any(Condition a) {
  return _mm256_movemask_ps(a.v) != 0;
}
static inline Floats select(Condition c, Floats yes, Floats no) {
  return {_mm256_blendv_ps(no.v, yes.v, c.v)};
}
static inline Ints select(Condition c, Ints yes, Ints no) {
  return {_mm256_castps_si256(_mm256_blendv_ps(_mm256_castsi256_ps(no.v), _mm256_castsi256_ps(yes.v), c.v))};
}
static inline void storeWhere(Condition c, std::int32_t* p, Ints a) {
  _mm256_maskstore_epi32(p, _mm256_castps_si256(c.v), a.v);
}
static inline Mask sharingBits(const std::uint32_t* p, std::uint32_t mask) {
  const __m256i shared =
      _mm256_and_si256(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(p)), _mm256_set1_epi32(static_cast<int>(mask)));
  const __m256i none = _mm256_cmpeq_epi32(shared, _mm256_setzero_si256());
  return static_cast<Mask>(~_mm256_movemask_ps(_mm256_castsi256_ps(none))) & 0xffu;
}

#else

// Vector extensions of GCC and Clang: four lanes on whatever the machine has. Without fused multiply-add.
constexpr int kLanes = 4;
using FloatVector __attribute__((vector_size(16))) = float;
using IntVector __attribute__((vector_size(16))) = std::int32_t;
struct Floats {
  FloatVector v;
};
struct Ints {
  IntVector v;
};
struct Condition {
  IntVector v;
};
static inline Floats load(const float* p) {
  return {FloatVector{p[0], p[1], p[2], p[3]}};
}
static inline void store(float* p, Floats a) {
  for (int i = 0; i < kLanes; ++i) p[i] = a.v[i];
}
static inline void store(std::int32_t* p, Ints a) {
  for (int i = 0; i < kLanes; ++i) p[i] = a.v[i];
}
static inline Floats all(float a) {
  return {FloatVector{a, a, a, a}};
}
static inline Ints all(std::int32_t a) {
  return {IntVector{a, a, a, a}};
}
static inline Floats operator+(Floats a, Floats b) {
  return {a.v + b.v};
}
static inline Floats operator-(Floats a, Floats b) {
  return {a.v - b.v};
}
static inline Floats operator*(Floats a, Floats b) {
  return {a.v * b.v};
}
static inline Floats multiplyAdd(Floats a, Floats b, Floats c) {
  return {a.v * b.v + c.v};
}
static inline Floats multiplySubtractFrom(Floats a, Floats b, Floats c) {
  return {c.v - a.v * b.v};
}
static inline Floats min(Floats a, Floats b) {
  return {a.v < b.v ? a.v : b.v};
}
static inline Floats max(Floats a, Floats b) {
  return {a.v > b.v ? a.v : b.v};
}
static inline Floats absolute(Floats a) {
  return {a.v < 0.0f ? -a.v : a.v};
}
static inline Condition less(Floats a, Floats b) {
  return {a.v < b.v};
}
static inline Condition operator&(Condition a, Condition b) {
  return {a.v & b.v};
}
static inline Condition operator|(Condition a, Condition b) {
  return {a.v | b.v};
}
static inline Mask bits(Condition a) {
  return static_cast<Mask>((a.v[0] & 1) | (a.v[1] & 2) | (a.v[2] & 4) | (a.v[3] & 8));
}
static inline bool any(Condition a) {
  return bits(a) != 0;
}
static inline Floats select(Condition c, Floats yes, Floats no) {
  return {c.v ? yes.v : no.v};
}
static inline Ints select(Condition c, Ints yes, Ints no) {
  return {c.v ? yes.v : no.v};
}
static inline void storeWhere(Condition c, std::int32_t* p, Ints a) {
  for (int i = 0; i < kLanes; ++i) p[i] = c.v[i] ? a.v[i] : p[i];
}
static inline Mask sharingBits(const std::uint32_t* p, std::uint32_t mask) {
  Mask shared = 0;
  for (unsigned i = 0; i < kLanes; ++i) shared |= static_cast<Mask>((p[i] & mask) != 0) << i;
  return shared;
}

#endif

}  // namespace overcast::OVERCAST_SIMD
