#include "bake/repair.h"
