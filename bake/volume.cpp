#include "bake/volume.h"
