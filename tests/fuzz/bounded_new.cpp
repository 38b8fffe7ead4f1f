// Memory as the sandbox gives it out: what only a broken file asks for ends in std::bad_alloc, where the address sanitizer's own operator
// new and the fuzzer's limit would end the fuzzer. What it allocates comes from malloc, which the sanitizer still watches.
#include <malloc.h>

#include <atomic>
#include <cstdlib>
#include <new>

namespace {

constexpr std::size_t kMostMemory = std::size_t{1} << 30;

std::atomic<std::size_t> inUse;

void* allocateOrNull(std::size_t size) noexcept {
  if (size > kMostMemory || inUse + size > kMostMemory) return nullptr;
  void* const memory = std::malloc(size > 0 ? size : 1);
  inUse += ::malloc_usable_size(memory);
  return memory;
}

void* allocate(std::size_t size) {
  void* const memory = allocateOrNull(size);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

void release(void* memory) noexcept {
  inUse -= ::malloc_usable_size(memory);
  std::free(memory);
}

}  // namespace

void* operator new(std::size_t size) {
  return allocate(size);
}
void* operator new[](std::size_t size) {
  return allocate(size);
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  return allocateOrNull(size);
}
void* operator new[](std::size_t size, const std::nothrow_t&) noexcept {
  return allocateOrNull(size);
}
void operator delete(void* memory) noexcept {
  release(memory);
}
void operator delete[](void* memory) noexcept {
  release(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
  release(memory);
}
void operator delete[](void* memory, std::size_t) noexcept {
  release(memory);
}
