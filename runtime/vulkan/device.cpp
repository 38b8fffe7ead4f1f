#include "runtime/vulkan/device.h"
