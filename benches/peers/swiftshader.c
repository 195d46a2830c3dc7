/* W1 to W5 on SwiftShader, the Vulkan driver that Chromium brings: no window, RGBA8 with 32-bit float depth.
 *
 * cc -O2 -o swiftshader swiftshader.c -lvulkan -lm; PEERS_SHADERS: the folder of shaders/ as glslangValidator compiled
 * them. VK_ICD_FILENAMES: Chromium's vk_swiftshader_icd.json. SwiftShader draws on as many threads as the machine has
 * cores, or as ThreadCount in the file SwiftShader.ini of the working folder says; one more thread feeds them.
 *
 * A timed frame is what llvmpipe.c times: both clears, the draw, and the wait until the picture is in the target's
 * memory; nothing is copied. The commands are recorded once and played in every frame. */
#include "scene3d.h"
#include "vulkan_device.h"

static const char *const PEER = "swiftshader";

static const VkFormat COLOR_FORMAT = VK_FORMAT_R8G8B8A8_UNORM, DEPTH_FORMAT = VK_FORMAT_D32_SFLOAT;

typedef struct {
    Matrix to_clip, model;
} Matrices;

static Image color, depth;
static VkDescriptorSetLayout set_layout;
static VkPipelineLayout pipeline_layout;

static void make_targets(void) {
    color = image(COLOR_FORMAT, VK_IMAGE_ASPECT_COLOR_BIT,
                  VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT, WIDTH, HEIGHT, 1);
    depth = image(DEPTH_FORMAT, VK_IMAGE_ASPECT_DEPTH_BIT, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT, WIDTH, HEIGHT,
                  1);
    VkDescriptorSetLayoutBinding binding = {0, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 1,
                                            VK_SHADER_STAGE_FRAGMENT_BIT, NULL};
    VkDescriptorSetLayoutCreateInfo set = {VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO, .bindingCount = 1,
                                           .pBindings = &binding};
    need(vkCreateDescriptorSetLayout(device, &set, NULL, &set_layout), "a set's layout");
    VkPushConstantRange matrices = {VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof(Matrices)};
    VkPipelineLayoutCreateInfo info = {VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO, .setLayoutCount = 1,
                                       .pSetLayouts = &set_layout, .pushConstantRangeCount = 1,
                                       .pPushConstantRanges = &matrices};
    need(vkCreatePipelineLayout(device, &info, NULL, &pipeline_layout), "a pipeline's layout");
}

/* The stage `name`.vert or `name`.frag. */
static VkPipelineShaderStageCreateInfo stage(const char *name, VkShaderStageFlagBits kind) {
    static uint32_t code[1 << 14];
    char path[1024];
    snprintf(path, sizeof path, "%s/%s.%s.spv", setting("PEERS_SHADERS", "shaders"), name,
             kind == VK_SHADER_STAGE_VERTEX_BIT ? "vert" : "frag");
    FILE *file = must(fopen(path, "rb"), path);
    VkShaderModuleCreateInfo info = {VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO,
                                     .codeSize = fread(code, 1, sizeof code, file), .pCode = code};
    fclose(file);
    VkShaderModule module;
    need(vkCreateShaderModule(device, &info, NULL, &module), path);
    return (VkPipelineShaderStageCreateInfo){VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO, .stage = kind,
                                             .module = module, .pName = "main"};
}

/* A viewport of negative height has y upwards, and depth clip control z in -w..w, so that OpenGL's matrices, faces and
 * depths are right here too. */
static VkPipeline pipeline(const char *name) {
    VkPipelineShaderStageCreateInfo stages[2] = {stage(name, VK_SHADER_STAGE_VERTEX_BIT),
                                                 stage(name, VK_SHADER_STAGE_FRAGMENT_BIT)};
    static const VkVertexInputBindingDescription vertex = {0, 32, VK_VERTEX_INPUT_RATE_VERTEX};
    static const VkVertexInputAttributeDescription attributes[3] = {{0, 0, VK_FORMAT_R32G32B32_SFLOAT, 0},
                                                                    {1, 0, VK_FORMAT_R32G32B32_SFLOAT, 12},
                                                                    {2, 0, VK_FORMAT_R32G32_SFLOAT, 24}};
    VkPipelineVertexInputStateCreateInfo input = {
        VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO, .vertexBindingDescriptionCount = 1,
        .pVertexBindingDescriptions = &vertex, .vertexAttributeDescriptionCount = 3,
        .pVertexAttributeDescriptions = attributes};
    VkPipelineInputAssemblyStateCreateInfo assembly = {VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO,
                                                       .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST};
    static const VkViewport whole = {0, HEIGHT, WIDTH, -HEIGHT, 0, 1};
    static const VkRect2D scissor = {{0, 0}, {WIDTH, HEIGHT}};
    VkPipelineViewportDepthClipControlCreateInfoEXT range = {
        VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_DEPTH_CLIP_CONTROL_CREATE_INFO_EXT, .negativeOneToOne = VK_TRUE};
    VkPipelineViewportStateCreateInfo viewport = {VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO, &range,
                                                  .viewportCount = 1, .pViewports = &whole, .scissorCount = 1,
                                                  .pScissors = &scissor};
    VkPipelineRasterizationStateCreateInfo faces = {VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO,
                                                    .cullMode = VK_CULL_MODE_BACK_BIT,
                                                    .frontFace = VK_FRONT_FACE_COUNTER_CLOCKWISE, .lineWidth = 1};
    VkPipelineMultisampleStateCreateInfo samples = {VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO,
                                                    .rasterizationSamples = VK_SAMPLE_COUNT_1_BIT};
    VkPipelineDepthStencilStateCreateInfo test = {VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO,
                                                  .depthTestEnable = VK_TRUE, .depthWriteEnable = VK_TRUE,
                                                  .depthCompareOp = VK_COMPARE_OP_LESS};
    static const VkPipelineColorBlendAttachmentState opaque = {.colorWriteMask = 15};
    VkPipelineColorBlendStateCreateInfo blend = {VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO,
                                                 .attachmentCount = 1, .pAttachments = &opaque};
    VkPipelineRenderingCreateInfo targets = {VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO,
                                             .colorAttachmentCount = 1, .pColorAttachmentFormats = &COLOR_FORMAT,
                                             .depthAttachmentFormat = DEPTH_FORMAT};
    VkGraphicsPipelineCreateInfo info = {
        VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO, &targets, .stageCount = 2, .pStages = stages,
        .pVertexInputState = &input, .pInputAssemblyState = &assembly, .pViewportState = &viewport,
        .pRasterizationState = &faces, .pMultisampleState = &samples, .pDepthStencilState = &test,
        .pColorBlendState = &blend, .layout = pipeline_layout};
    VkPipeline made;
    need(vkCreateGraphicsPipelines(device, VK_NULL_HANDLE, 1, &info, NULL, &made), name);
    return made;
}

typedef struct {
    VkPipeline pipeline;
    VkBuffer vertices, indices;
    uint32_t count;
    VkDescriptorSet texture; /* VK_NULL_HANDLE: none */
} Draw;

static Draw mesh_draw(VkPipeline pipeline, const Mesh *mesh) {
    Buffer vertices = buffer(VK_BUFFER_USAGE_VERTEX_BUFFER_BIT, mesh->vertices, (size_t)mesh->vertex_count * 32);
    Buffer indices = buffer(VK_BUFFER_USAGE_INDEX_BUFFER_BIT, mesh->indices, (size_t)mesh->triangle_count * 12);
    return (Draw){pipeline, vertices.name, indices.name, mesh->triangle_count * 3, VK_NULL_HANDLE};
}

/* Returns a target that is cleared before it is drawn into. */
static VkRenderingAttachmentInfo cleared(Image image, VkClearValue value) {
    return (VkRenderingAttachmentInfo){VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO, .imageView = image.view,
                                       .imageLayout = VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL,
                                       .loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR,
                                       .storeOp = VK_ATTACHMENT_STORE_OP_STORE, .clearValue = value};
}

/* Returns the commands of a whole frame: the clears and the draw. */
static VkCommandBuffer record(Draw draw) {
    VkCommandBuffer commands = begin_commands();
    change_layout(commands, color, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL);
    change_layout(commands, depth, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL);
    VkRenderingAttachmentInfo colors = cleared(color, (VkClearValue){.color = {{0.1f, 0.1f, 0.15f, 1}}});
    VkRenderingAttachmentInfo depths = cleared(depth, (VkClearValue){.depthStencil = {1, 0}});
    VkRenderingInfo rendering = {VK_STRUCTURE_TYPE_RENDERING_INFO, .renderArea = {{0, 0}, {WIDTH, HEIGHT}},
                                 .layerCount = 1, .colorAttachmentCount = 1, .pColorAttachments = &colors,
                                 .pDepthAttachment = &depths};
    vkCmdBeginRendering(commands, &rendering);
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, draw.pipeline);
    if (draw.texture)
        vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline_layout, 0, 1, &draw.texture, 0,
                                NULL);
    Matrices matrices = {product(camera_matrix(), model_matrix()), model_matrix()};
    vkCmdPushConstants(commands, pipeline_layout, VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof matrices, &matrices);
    static const VkDeviceSize start = 0;
    vkCmdBindVertexBuffers(commands, 0, 1, &draw.vertices, &start);
    vkCmdBindIndexBuffer(commands, draw.indices, 0, VK_INDEX_TYPE_UINT32);
    vkCmdDrawIndexed(commands, draw.count, 1, 0, 0, 0);
    vkCmdEndRendering(commands);
    need(vkEndCommandBuffer(commands), "recorded commands");
    return commands;
}

static void frame(void *job) {
    play(*(VkCommandBuffer *)job);
}

static void run(const char *workload, Draw draw) {
    VkCommandBuffer commands = record(draw);
    measure(PEER, workload, frame, &commands);
    frame(&commands);
    Buffer pixels = buffer(VK_BUFFER_USAGE_TRANSFER_DST_BIT, NULL, (size_t)WIDTH * HEIGHT * 4);
    VkCommandBuffer copy = begin_commands();
    change_layout(copy, color, VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
    VkBufferImageCopy whole = {.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1},
                               .imageExtent = {WIDTH, HEIGHT, 1}};
    vkCmdCopyImageToBuffer(copy, color.name, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, pixels.name, 1, &whole);
    end_and_play(copy);
    save_picture(PEER, workload, pixels.bytes, 0, 2, 0);
}

/* Returns the texture with all its levels, each the mean of four texels of the one before. */
static Image load_levels(void) {
    enum { LEVELS = 11 };
    Image made = image(COLOR_FORMAT, VK_IMAGE_ASPECT_COLOR_BIT,
                       VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT,
                       TEXTURE_SIDE, TEXTURE_SIDE, LEVELS);
    Buffer texels = buffer(VK_BUFFER_USAGE_TRANSFER_SRC_BIT, load_texture(), (size_t)TEXTURE_SIDE * TEXTURE_SIDE * 4);
    VkCommandBuffer commands = begin_commands();
    change_layout(commands, made, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_GENERAL);
    VkBufferImageCopy first = {.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1},
                               .imageExtent = {TEXTURE_SIDE, TEXTURE_SIDE, 1}};
    vkCmdCopyBufferToImage(commands, texels.name, made.name, VK_IMAGE_LAYOUT_GENERAL, 1, &first);
    for (uint32_t level = 1; level < LEVELS; level++) {
        int32_t from = TEXTURE_SIDE >> (level - 1), to = TEXTURE_SIDE >> level;
        VkImageBlit half = {{VK_IMAGE_ASPECT_COLOR_BIT, level - 1, 0, 1}, {{0, 0, 0}, {from, from, 1}},
                            {VK_IMAGE_ASPECT_COLOR_BIT, level, 0, 1}, {{0, 0, 0}, {to, to, 1}}};
        change_layout(commands, made, VK_IMAGE_LAYOUT_GENERAL, VK_IMAGE_LAYOUT_GENERAL);
        vkCmdBlitImage(commands, made.name, VK_IMAGE_LAYOUT_GENERAL, made.name, VK_IMAGE_LAYOUT_GENERAL, 1, &half,
                       VK_FILTER_LINEAR);
    }
    change_layout(commands, made, VK_IMAGE_LAYOUT_GENERAL, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
    end_and_play(commands);
    return made;
}

/* Returns a set with the texture, sampled by `filter`, between two levels where `last_level` is not 0. */
static VkDescriptorSet texture_set(Image texture, VkFilter filter, float last_level) {
    VkSamplerCreateInfo sampling = {VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO, .magFilter = filter, .minFilter = filter,
                                    .mipmapMode = last_level > 0 ? VK_SAMPLER_MIPMAP_MODE_LINEAR
                                                                 : VK_SAMPLER_MIPMAP_MODE_NEAREST,
                                    .maxLod = last_level};
    VkDescriptorImageInfo source = {.imageView = texture.view,
                                    .imageLayout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
    need(vkCreateSampler(device, &sampling, NULL, &source.sampler), "a sampler");
    VkDescriptorPoolSize size = {VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 1};
    VkDescriptorPoolCreateInfo one = {VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO, .maxSets = 1,
                                      .poolSizeCount = 1, .pPoolSizes = &size};
    VkDescriptorPool pool;
    need(vkCreateDescriptorPool(device, &one, NULL, &pool), "a descriptor pool");
    VkDescriptorSetAllocateInfo info = {VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO, NULL, pool, 1, &set_layout};
    VkDescriptorSet made;
    need(vkAllocateDescriptorSets(device, &info, &made), "a descriptor set");
    VkWriteDescriptorSet write = {VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET, .dstSet = made, .descriptorCount = 1,
                                  .descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, .pImageInfo = &source};
    vkUpdateDescriptorSets(device, 1, &write, 0, NULL);
    return made;
}

static void run_textured(const Mesh *knot) {
    Image texture = load_levels();
    Draw draw = mesh_draw(pipeline("textured"), knot);
    draw.texture = texture_set(texture, VK_FILTER_LINEAR, VK_LOD_CLAMP_NONE);
    run("W4_tex_trilinear", draw);
    draw.texture = texture_set(texture, VK_FILTER_LINEAR, 0);
    run("W4_tex_bilinear", draw);
    draw.texture = texture_set(texture, VK_FILTER_NEAREST, 0);
    run("W4_tex_nearest", draw);
}

int main(void) {
    open_device(VK_DRIVER_ID_GOOGLE_SWIFTSHADER);
    make_targets();
    Mesh knot = load_mesh("knot70k.bin"), layers = layer_mesh();
    if (is_wanted("W1")) run("W1_phong70k", mesh_draw(pipeline("phong"), &knot));
    if (is_wanted("W2")) {
        Mesh large = load_mesh("knot1m.bin");
        run("W2_phong1M", mesh_draw(pipeline("phong"), &large));
    }
    if (is_wanted("W3")) run("W3_fill20", mesh_draw(pipeline("layer"), &layers));
    if (is_wanted("W4")) run_textured(&knot);
    if (is_wanted("W5")) run("W5_gouraud70k", mesh_draw(pipeline("gouraud"), &knot));
    return 0;
}
