#include "bake/distance.h"
