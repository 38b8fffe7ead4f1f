#include "bake/sign.h"
