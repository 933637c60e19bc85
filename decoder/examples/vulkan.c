/* Example 3: the same GLSL in Vulkan. A compute shader decodes a material at given directions, each
 * invocation at another of its levels of detail; the result is compared with the reference decoder, bit for
 * bit.
 *
 *     vulkan FILE.btf.exr > decode.comp                        prints the shader
 *     glslangValidator -V decode.comp -o decode.spv            to SPIR-V
 *     vulkan FILE.btf.exr decode.spv                           runs it; exit code 7 when a bit differs
 *
 * SPDX-License-Identifier: MIT
 */
#include "decoder/toolkit/reference_view.h"
#include <math.h>
#include <openbtf/shader.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <vulkan/vulkan.h>

enum { COUNT = 64 * 256, GROUP = 64, FIRST_BINDING = 2 };

static const char shader_head[] = "#version 450\n";
static const char shader_body[] =
    "layout(local_size_x = 64) in;\n"
    "layout(set = 0, binding = 0) readonly buffer Inputs { float inputs[]; };\n"
    "layout(set = 0, binding = 1) writeonly buffer Outputs { float outputs[]; };\n"
    "void main() {\n"
    "    uint i = gl_GlobalInvocationID.x, at = 8u * i;\n"
    "    vec3 l = vec3(inputs[at + 5u], inputs[at + 6u], inputs[at + 7u]);\n"
    "    vec3 v = vec3(inputs[at + 2u], inputs[at + 3u], inputs[at + 4u]);\n"
    "    vec3 radiance = btf_evaluate_level(vec2(inputs[at], inputs[at + 1u]), l, v, int(i % "
    "BTF_LEVELS));\n"
    "    for (uint c = 0u; c < 3u; ++c)\n"
    "        outputs[3u * i + c] = radiance[c];\n"
    "}\n";

static const btf_shader_options options = {
    .struct_size = sizeof options, .bindings = BTF_BINDINGS_VULKAN, .first_binding = FIRST_BINDING};

/* The most objects of a kind: an image and its staging buffer for each texture, and two buffers. */
enum { MOST = 2 * BTF_TEXTURE_COUNT + 2 };

typedef struct gpu {
    VkInstance instance;
    VkPhysicalDevice physical;
    VkDevice device;
    VkQueue queue;
    uint32_t family;
    VkCommandPool pool;
    VkSampler sampler;
    VkDescriptorSetLayout set_layout;
    VkDescriptorPool descriptors;
    VkDescriptorSet set;
    VkPipelineLayout layout;
    VkPipeline pipeline;
    /* these are destroyed before the device: see close_device */
    VkBuffer buffers[MOST];
    VkImage images[MOST];
    VkImageView views[MOST];
    VkDeviceMemory memories[MOST];
    uint32_t buffer_count, image_count, view_count, memory_count;
} gpu;

typedef struct buffer {
    VkBuffer name;
    void *data;
} buffer;

/* Errors of an example: says where, and ends the program. */
static void check(VkResult result, const char *what) {
    if (result != VK_SUCCESS) {
        fprintf(stderr, "vulkan: %s: error %d\n", what, (int)result);
        exit(4);
    }
}

static void print_message(void *user, btf_log_level level, const char *message) {
    (void)user;
    (void)level;
    fprintf(stderr, "vulkan: %s\n", message);
}
static const btf_log log_stderr = {print_message, NULL};

/* A device with a queue that computes; 0 when there is none. */
static int open_device(gpu *g) {
    const VkApplicationInfo application = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO,
                                           .apiVersion = VK_API_VERSION_1_0};
    const VkInstanceCreateInfo instance = {.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
                                           .pApplicationInfo = &application};
    uint32_t count = 1, families = 8;
    if (vkCreateInstance(&instance, NULL, &g->instance) != VK_SUCCESS) {
        return 0;
    }
    if (vkEnumeratePhysicalDevices(g->instance, &count, &g->physical) < 0 || count == 0) {
        return 0;
    }
    VkQueueFamilyProperties properties[8];
    vkGetPhysicalDeviceQueueFamilyProperties(g->physical, &families, properties);
    while (g->family < families && !(properties[g->family].queueFlags & VK_QUEUE_COMPUTE_BIT)) {
        g->family++;
    }
    if (g->family == families) {
        return 0;
    }
    const float priority = 1;
    const VkDeviceQueueCreateInfo queue = {.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                                           .queueFamilyIndex = g->family,
                                           .queueCount = 1,
                                           .pQueuePriorities = &priority};
    const VkDeviceCreateInfo device = {.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                                       .queueCreateInfoCount = 1,
                                       .pQueueCreateInfos = &queue};
    check(vkCreateDevice(g->physical, &device, NULL, &g->device), "device");
    vkGetDeviceQueue(g->device, g->family, 0, &g->queue);
    const VkCommandPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                          .queueFamilyIndex = g->family};
    check(vkCreateCommandPool(g->device, &pool, NULL, &g->pool), "command pool");
    const VkSamplerCreateInfo sampler = {.sType = VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO};
    check(vkCreateSampler(g->device, &sampler, NULL, &g->sampler), "sampler");
    return 1;
}

static void close_device(gpu *g) {
    vkDestroyPipeline(g->device, g->pipeline, NULL);
    vkDestroyPipelineLayout(g->device, g->layout, NULL);
    vkDestroyDescriptorPool(g->device, g->descriptors, NULL);
    vkDestroyDescriptorSetLayout(g->device, g->set_layout, NULL);
    for (uint32_t i = 0; i < g->view_count; i++) {
        vkDestroyImageView(g->device, g->views[i], NULL);
    }
    for (uint32_t i = 0; i < g->image_count; i++) {
        vkDestroyImage(g->device, g->images[i], NULL);
    }
    for (uint32_t i = 0; i < g->buffer_count; i++) {
        vkDestroyBuffer(g->device, g->buffers[i], NULL);
    }
    for (uint32_t i = 0; i < g->memory_count; i++) {
        vkFreeMemory(g->device, g->memories[i], NULL);
    }
    vkDestroySampler(g->device, g->sampler, NULL);
    vkDestroyCommandPool(g->device, g->pool, NULL);
    vkDestroyDevice(g->device, NULL);
    vkDestroyInstance(g->instance, NULL);
}

static VkDeviceMemory allocate(gpu *g, VkMemoryRequirements need, VkMemoryPropertyFlags flags) {
    VkPhysicalDeviceMemoryProperties have;
    VkDeviceMemory memory;
    vkGetPhysicalDeviceMemoryProperties(g->physical, &have);
    for (uint32_t i = 0; i < have.memoryTypeCount; i++) {
        if (need.memoryTypeBits >> i & 1 && (have.memoryTypes[i].propertyFlags & flags) == flags) {
            const VkMemoryAllocateInfo info = {.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                                               .allocationSize = need.size,
                                               .memoryTypeIndex = i};
            check(vkAllocateMemory(g->device, &info, NULL, &memory), "memory");
            return g->memories[g->memory_count++] = memory;
        }
    }
    check(VK_ERROR_OUT_OF_DEVICE_MEMORY, "no memory of that kind");
    return VK_NULL_HANDLE;
}

/* A buffer that the CPU sees, mapped for good. */
static buffer make_buffer(gpu *g, size_t size, VkBufferUsageFlags usage) {
    buffer b = {0};
    const VkBufferCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO, .size = size, .usage = usage};
    VkMemoryRequirements need;
    check(vkCreateBuffer(g->device, &info, NULL, &b.name), "buffer");
    g->buffers[g->buffer_count++] = b.name;
    vkGetBufferMemoryRequirements(g->device, b.name, &need);
    VkDeviceMemory memory =
        allocate(g, need, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT);
    check(vkBindBufferMemory(g->device, b.name, memory, 0), "buffer memory");
    check(vkMapMemory(g->device, memory, 0, VK_WHOLE_SIZE, 0, &b.data), "mapping");
    return b;
}

static VkCommandBuffer begin(const gpu *g) {
    VkCommandBuffer commands;
    const VkCommandBufferAllocateInfo info = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                              .commandPool = g->pool,
                                              .commandBufferCount = 1};
    const VkCommandBufferBeginInfo start = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    check(vkAllocateCommandBuffers(g->device, &info, &commands), "command buffer");
    check(vkBeginCommandBuffer(commands, &start), "command buffer");
    return commands;
}

static void submit(const gpu *g, VkCommandBuffer commands) {
    const VkSubmitInfo info = {
        .sType = VK_STRUCTURE_TYPE_SUBMIT_INFO, .commandBufferCount = 1, .pCommandBuffers = &commands};
    check(vkEndCommandBuffer(commands), "command buffer");
    check(vkQueueSubmit(g->queue, 1, &info, VK_NULL_HANDLE), "submission");
    check(vkQueueWaitIdle(g->queue), "waiting");
}

static void move_image(VkCommandBuffer commands, VkImage image, VkImageSubresourceRange range,
                       VkImageLayout from, VkImageLayout to) {
    const VkImageMemoryBarrier barrier = {.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER,
                                          .srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT,
                                          .dstAccessMask =
                                              VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_TRANSFER_WRITE_BIT,
                                          .oldLayout = from,
                                          .newLayout = to,
                                          .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                                          .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                                          .image = image,
                                          .subresourceRange = range};
    vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
                         0, 0, NULL, 0, NULL, 1, &barrier);
}

static VkFormat format_of(btf_format format) {
    static const VkFormat formats[] = {
        [BTF_FORMAT_R8UI] = VK_FORMAT_R8_UINT,
        [BTF_FORMAT_RG8UI] = VK_FORMAT_R8G8_UINT,
        [BTF_FORMAT_RGBA8UI] = VK_FORMAT_R8G8B8A8_UINT,
        [BTF_FORMAT_RGBA8I] = VK_FORMAT_R8G8B8A8_SINT,
        [BTF_FORMAT_RGBA16UI] = VK_FORMAT_R16G16B16A16_UINT,
        [BTF_FORMAT_RGBA16F] = VK_FORMAT_R16G16B16A16_SFLOAT,
        [BTF_FORMAT_RGBA32F] = VK_FORMAT_R32G32B32A32_SFLOAT,
        [BTF_FORMAT_RGBA32UI] = VK_FORMAT_R32G32B32A32_UINT,
    };
    return formats[format];
}

/* The library hands textures out as plain memory: they go up as they are, levels of detail as mip levels. */
static VkImageView upload(gpu *g, const btf_material *material, btf_texture_id id) {
    VkImage image;
    VkImageView view;
    VkMemoryRequirements need;
    VkBufferImageCopy regions[BTF_MAX_LEVELS];
    btf_texture t[BTF_MAX_LEVELS];
    uint32_t levels = 0;
    size_t size = 0;
    for (; levels < BTF_MAX_LEVELS; levels++) {
        t[levels] = btf_material_level_texture(material, levels, id);
        if (t[levels].format == BTF_FORMAT_NONE) {
            break;
        }
        regions[levels] = (VkBufferImageCopy){
            .bufferOffset = size,
            .imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, levels, 0, t[levels].layers},
            .imageExtent = {t[levels].width, t[levels].height, 1}};
        size += (t[levels].size + 15) & ~(size_t)15; /* offsets are multiples of every texel's size */
    }
    const VkImageCreateInfo info = {.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                                    .imageType = VK_IMAGE_TYPE_2D,
                                    .format = format_of(t->format),
                                    .extent = {t->width, t->height, 1},
                                    .mipLevels = levels,
                                    .arrayLayers = t->layers,
                                    .samples = VK_SAMPLE_COUNT_1_BIT,
                                    .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT};
    const VkImageSubresourceRange range = {VK_IMAGE_ASPECT_COLOR_BIT, 0, levels, 0, t->layers};
    check(vkCreateImage(g->device, &info, NULL, &image), "image");
    g->images[g->image_count++] = image;
    vkGetImageMemoryRequirements(g->device, image, &need);
    check(vkBindImageMemory(g->device, image, allocate(g, need, 0), 0), "image memory");
    buffer staging = make_buffer(g, size, VK_BUFFER_USAGE_TRANSFER_SRC_BIT);
    for (uint32_t i = 0; i < levels; i++) {
        memcpy((char *)staging.data + regions[i].bufferOffset, t[i].data, t[i].size);
    }
    VkCommandBuffer commands = begin(g);
    move_image(commands, image, range, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    vkCmdCopyBufferToImage(commands, staging.name, image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, levels,
                           regions);
    move_image(commands, image, range, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
               VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
    submit(g, commands);
    const VkImageViewCreateInfo view_info = {.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
                                             .image = image,
                                             .viewType = t->is_array ? VK_IMAGE_VIEW_TYPE_2D_ARRAY
                                                                     : VK_IMAGE_VIEW_TYPE_2D,
                                             .format = info.format,
                                             .subresourceRange = range};
    check(vkCreateImageView(g->device, &view_info, NULL, &view), "image view");
    return g->views[g->view_count++] = view;
}

static void add_binding(VkDescriptorSetLayoutBinding *bindings, uint32_t *count, uint32_t binding,
                        VkDescriptorType type) {
    bindings[(*count)++] = (VkDescriptorSetLayoutBinding){.binding = binding,
                                                          .descriptorType = type,
                                                          .descriptorCount = 1,
                                                          .stageFlags = VK_SHADER_STAGE_COMPUTE_BIT};
}

/* Two buffers, and the textures that the shader reads: texture id i at binding FIRST_BINDING + i. */
static void make_set(gpu *g, uint32_t textures) {
    VkDescriptorSetLayoutBinding bindings[2 + BTF_TEXTURE_COUNT];
    uint32_t count = 0;
    add_binding(bindings, &count, 0, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER);
    add_binding(bindings, &count, 1, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER);
    for (uint32_t i = 0; i < BTF_TEXTURE_COUNT; i++) {
        if (textures >> i & 1) {
            add_binding(bindings, &count, FIRST_BINDING + i, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER);
        }
    }
    const VkDescriptorSetLayoutCreateInfo layout = {.sType =
                                                        VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
                                                    .bindingCount = count,
                                                    .pBindings = bindings};
    check(vkCreateDescriptorSetLayout(g->device, &layout, NULL, &g->set_layout), "set layout");
    const VkDescriptorPoolSize sizes[2] = {{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 2},
                                           {VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, BTF_TEXTURE_COUNT}};
    const VkDescriptorPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
                                             .maxSets = 1,
                                             .poolSizeCount = 2,
                                             .pPoolSizes = sizes};
    check(vkCreateDescriptorPool(g->device, &pool, NULL, &g->descriptors), "descriptor pool");
    const VkDescriptorSetAllocateInfo set = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                             .descriptorPool = g->descriptors,
                                             .descriptorSetCount = 1,
                                             .pSetLayouts = &g->set_layout};
    check(vkAllocateDescriptorSets(g->device, &set, &g->set), "descriptor set");
}

static void bind_buffer(const gpu *g, uint32_t binding, const buffer *b) {
    const VkDescriptorBufferInfo info = {b->name, 0, VK_WHOLE_SIZE};
    const VkWriteDescriptorSet write = {.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                        .dstSet = g->set,
                                        .dstBinding = binding,
                                        .descriptorCount = 1,
                                        .descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER,
                                        .pBufferInfo = &info};
    vkUpdateDescriptorSets(g->device, 1, &write, 0, NULL);
}

static void bind_texture(gpu *g, uint32_t binding, const btf_material *material, btf_texture_id id) {
    const VkDescriptorImageInfo info = {g->sampler, upload(g, material, id),
                                        VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
    const VkWriteDescriptorSet write = {.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                        .dstSet = g->set,
                                        .dstBinding = binding,
                                        .descriptorCount = 1,
                                        .descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER,
                                        .pImageInfo = &info};
    vkUpdateDescriptorSets(g->device, 1, &write, 0, NULL);
}

static void make_pipeline(gpu *g, const uint32_t *code, size_t size) {
    VkShaderModule module;
    const VkShaderModuleCreateInfo shader = {
        .sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO, .codeSize = size, .pCode = code};
    check(vkCreateShaderModule(g->device, &shader, NULL, &module), "SPIR-V");
    const VkPipelineLayoutCreateInfo layout = {.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                               .setLayoutCount = 1,
                                               .pSetLayouts = &g->set_layout};
    check(vkCreatePipelineLayout(g->device, &layout, NULL, &g->layout), "pipeline layout");
    const VkComputePipelineCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
        .stage = {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                  .stage = VK_SHADER_STAGE_COMPUTE_BIT,
                  .module = module,
                  .pName = "main"},
        .layout = g->layout};
    check(vkCreateComputePipelines(g->device, VK_NULL_HANDLE, 1, &info, NULL, &g->pipeline), "pipeline");
    vkDestroyShaderModule(g->device, module, NULL);
}

/* u, v, view, light: the same numbers everywhere. */
static void make_inputs(float *inputs) {
    uint32_t seed = 1;
    for (int i = 0; i < COUNT; i++, inputs += 8) {
        double r[6];
        for (int k = 0; k < 6; k++) {
            seed = seed * 1664525u + 1013904223u;
            r[k] = (double)(seed >> 8) / (1 << 24);
        }
        inputs[0] = (float)(4 * r[0] - 2);
        inputs[1] = (float)(4 * r[1] - 2);
        for (int k = 0; k < 2; k++) {
            double z = r[2 + 2 * k] * 1.05 - 0.05, s = sqrt(fmax(0, 1 - z * z)),
                   phi = 6.283185307179586 * r[3 + 2 * k];
            inputs[2 + 3 * k] = (float)(s * cos(phi));
            inputs[3 + 3 * k] = (float)(s * sin(phi));
            inputs[4 + 3 * k] = (float)z;
        }
    }
}

static int compare(const btf_material *material, const float *inputs, const float *outputs) {
    const btf_ref_options decode = {BTF_EFFECT_ALL, UINT32_MAX, BTF_REF_LINEAR, BTF_REF_TEXEL};
    btf_ref_material levels[BTF_MAX_LEVELS];
    btf_material_info info = {.struct_size = sizeof info};
    int different = 0;
    btf_material_get_info(material, &info);
    for (uint32_t i = 0; i < info.levels; i++) {
        reference_view(material, i, &levels[i]);
    }
    for (int i = 0; i < COUNT; i++, inputs += 8, outputs += 3) {
        float expected[3];
        btf_ref_evaluate(&levels[(uint32_t)i % info.levels], &decode, inputs[0], inputs[1], inputs + 5,
                         inputs + 2, expected);
        different += memcmp(expected, outputs, sizeof expected) != 0;
    }
    printf("%d of %d differ\n", different, COUNT);
    return different ? 7 : 0;
}

static int run(const btf_material *material, const uint32_t *code, size_t size) {
    gpu g = {0};
    btf_material_info info = {.struct_size = sizeof info};
    VkPhysicalDeviceProperties properties;
    if (!open_device(&g)) {
        fprintf(stderr, "vulkan: no device that computes\n");
        return 5;
    }
    vkGetPhysicalDeviceProperties(g.physical, &properties);
    printf("%s\n", properties.deviceName);
    btf_material_get_info(material, &info);
    const uint32_t textures = btf_shader_textures(&info, &options);
    make_set(&g, textures);
    buffer inputs = make_buffer(&g, COUNT * 8 * sizeof(float), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
    buffer outputs = make_buffer(&g, COUNT * 3 * sizeof(float), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
    bind_buffer(&g, 0, &inputs);
    bind_buffer(&g, 1, &outputs);
    for (uint32_t i = 0; i < BTF_TEXTURE_COUNT; i++) {
        if (textures >> i & 1) {
            bind_texture(&g, FIRST_BINDING + i, material, (btf_texture_id)i);
        }
    }
    make_pipeline(&g, code, size);
    make_inputs(inputs.data);
    VkCommandBuffer commands = begin(&g);
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, g.pipeline);
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, g.layout, 0, 1, &g.set, 0, NULL);
    vkCmdDispatch(commands, COUNT / GROUP, 1, 1);
    const VkMemoryBarrier barrier = {.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
                                     .srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT,
                                     .dstAccessMask = VK_ACCESS_HOST_READ_BIT};
    vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_PIPELINE_STAGE_HOST_BIT, 0, 1,
                         &barrier, 0, NULL, 0, NULL);
    submit(&g, commands);
    const int exit_code = compare(material, inputs.data, outputs.data);
    close_device(&g);
    return exit_code;
}

static int run_file(const btf_material *material, const char *path) {
    static uint32_t code[1 << 18];
    FILE *file = fopen(path, "rb");
    size_t size = file ? fread(code, 1, sizeof code, file) : 0;
    if (file) {
        fclose(file);
    }
    if (size == 0 || size % 4 || size == sizeof code) {
        fprintf(stderr, "vulkan: %s: cannot be read\n", path);
        return 2;
    }
    return run(material, code, size);
}

int main(int argc, char **argv) {
    btf_material *material = NULL;
    char *library = NULL;
    if (argc != 2 && argc != 3) {
        fprintf(stderr, "usage: vulkan FILE.btf.exr [decode.spv]\n");
        return 1;
    }
    btf_result result = btf_material_open(argv[1], &log_stderr, &material);
    if (!result && argc == 2) {
        result = btf_shader_source(material, &options, &log_stderr, &library);
    }
    if (library && printf("%s%s%s", shader_head, library, shader_body) < 0) {
        result = BTF_ERROR_IO;
    }
    int exit_code = btf_result_exit_code(result);
    if (!result && argc == 3) {
        exit_code = run_file(material, argv[2]);
    }
    btf_free(library);
    btf_material_close(&material);
    return exit_code;
}
