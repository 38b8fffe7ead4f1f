// One thread per pixel: the sky's light times a constant.
#version 460
#include "runtime/passes/constant/constant.h"
#include "runtime/passes/screen/screen.glsl"

layout(push_constant) uniform Push {
  ConstantPush push;
};

void main() {
  ivec2 pixel;
  vec3 place;
  if (surfaceOfThread(mat4(1.0f), pixel, place)) writeLight(pixel, push.sky.rgb * push.sky.w, push.sky.w);
}
